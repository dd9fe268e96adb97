within RobotIdentification.Benchmarks;
model Chain8 "Planar chain of 8 links: torques in, positions and velocities out"
  extends Plants.Chain(n=8);
  annotation (
    experiment(StopTime=1, Interval=0.01),
    Documentation(info="<html>
<p><a href=\"modelica://RobotIdentification.Plants.Chain\">Plants.Chain</a> with 8 links, for export.</p>
</html>"));
end Chain8;

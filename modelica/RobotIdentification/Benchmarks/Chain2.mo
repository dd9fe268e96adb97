within RobotIdentification.Benchmarks;
model Chain2 "Planar chain of 2 links: torques in, positions and velocities out"
  extends Plants.Chain(n=2);
  annotation (
    experiment(StopTime=1, Interval=0.01),
    Documentation(info="<html>
<p><a href=\"modelica://RobotIdentification.Plants.Chain\">Plants.Chain</a> with 2 links, for export.</p>
</html>"));
end Chain2;

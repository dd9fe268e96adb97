within RobotIdentification.Benchmarks;
model Chain16 "Planar chain of 16 links: torques in, positions and velocities out"
  extends Plants.Chain(n=16);
  annotation (
    experiment(StopTime=1, Interval=0.01),
    Documentation(info="<html>
<p><a href=\"modelica://RobotIdentification.Plants.Chain\">Plants.Chain</a> with 16 links, for export.</p>
</html>"));
end Chain16;

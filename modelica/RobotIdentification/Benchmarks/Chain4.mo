within RobotIdentification.Benchmarks;
model Chain4 "Planar chain of 4 links: torques in, positions and velocities out"
  extends Plants.Chain(n=4);
  annotation (
    experiment(StopTime=1, Interval=0.01),
    Documentation(info="<html>
<p><a href=\"modelica://RobotIdentification.Plants.Chain\">Plants.Chain</a> with 4 links, for export.</p>
</html>"));
end Chain4;

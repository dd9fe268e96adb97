within RobotIdentification.FMUs;
model Scara "Two-joint SCARA robot: torques in, positions and velocities out"
  extends Plants.Scara;
  annotation (
    experiment(StopTime=1, Interval=0.01),
    Documentation(info="<html>
<p>
<a href=\"modelica://RobotIdentification.Plants.Scara\">Plants.Scara</a> for export: the robot of Gautier and Poignet,
Control Engineering Practice 9 (2001) 1361&ndash;1372.
</p>
</html>"));
end Scara;

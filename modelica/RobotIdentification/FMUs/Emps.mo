within RobotIdentification.FMUs;
model Emps "EMPS drive: command in volts in, position and velocity out"
  extends Plants.Emps;
  annotation (
    experiment(StopTime=1, Interval=0.001),
    Documentation(info="<html>
<p>
<a href=\"modelica://RobotIdentification.Plants.Emps\">Plants.Emps</a> for export: the EMPS benchmark of A. Janot, M.
Gautier and M. Brunot.
</p>
</html>"));
end Emps;

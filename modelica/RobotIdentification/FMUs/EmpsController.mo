within RobotIdentification.FMUs;
block EmpsController "Two-loop position controller of the EMPS drive, 1 kHz"
  extends Components.TwoLoopController;
  annotation (
    experiment(StopTime=1, Interval=0.001),
    Documentation(info="<html>
<p>
<a href=\"modelica://RobotIdentification.Components.TwoLoopController\">TwoLoopController</a> for export: the
published controller of the EMPS benchmark of A. Janot, M. Gautier and M. Brunot.
</p>
</html>"));
end EmpsController;

within RobotIdentification.Examples;
model EmpsLoop "EMPS drive under its two-loop controller"
  Components.CosineSlide reference(amplitude=0.05, period=2) "Stroke of the carriage";
  FMUs.EmpsClosedLoop closedLoop(G=35) "Drive and controller; the gain is a round number, good enough for an example";
equation
  connect(reference.qr, closedLoop.qr);
  closedLoop.pulse = 0;
  annotation (
    experiment(StopTime=4, Interval=0.001),
    Documentation(info="<html>
<p>
The EMPS benchmark drive of A. Janot, M. Gautier and M. Brunot moves forth and back under its published controller. Plot
closedLoop.q against reference.qr, and closedLoop.u around the reversals, where the Coulomb friction changes its sign.
</p>
</html>"));
end EmpsLoop;

within RobotIdentification.Examples;
model ScaraSampledLoop "SCARA robot under its sampled controller"
  Components.CosineMotion reference_1(amplitude=0.6, period=2.5) "Swing of joint 1";
  Components.CosineMotion reference_2(amplitude=0.9, period=1.25) "Swing of joint 2";
  FMUs.ScaraClosedLoop closedLoop "Robot and controller";
equation
  connect(reference_1.qr, closedLoop.qr_1);
  connect(reference_1.qdr, closedLoop.qdr_1);
  connect(reference_2.qr, closedLoop.qr_2);
  connect(reference_2.qdr, closedLoop.qdr_2);
  annotation (
    experiment(StopTime=5, Interval=0.01),
    Documentation(info="<html>
<p>
The robot of Gautier and Poignet, Control Engineering Practice 9 (2001), swings both joints under the PD controller
that is sampled at 100 Hz. Plot closedLoop.q_1 against reference_1.qr, and closedLoop.tau_1: the torque is held
between the samples.
</p>
</html>"));
end ScaraSampledLoop;

within RobotIdentification.Examples;
model ScaraContinuousLoop "SCARA robot under its continuous controller"
  Components.CosineMotion reference_1(amplitude=0.6, period=2.5) "Swing of joint 1";
  Components.CosineMotion reference_2(amplitude=0.9, period=1.25) "Swing of joint 2";
  Plants.Scara plant "Robot";
  FMUs.ScaraControllerContinuous controller "Controller";
equation
  connect(reference_1.qr, controller.qr_1);
  connect(reference_1.qdr, controller.qdr_1);
  connect(reference_2.qr, controller.qr_2);
  connect(reference_2.qdr, controller.qdr_2);
  connect(plant.q_1, controller.q_1);
  connect(plant.q_2, controller.q_2);
  connect(controller.tau_1, plant.tau_1);
  connect(controller.tau_2, plant.tau_2);
  annotation (
    experiment(StopTime=5, Interval=0.01),
    Documentation(info="<html>
<p>
As <a href=\"modelica://RobotIdentification.Examples.ScaraSampledLoop\">ScaraSampledLoop</a>, with the controller in
continuous time: the difference between the two is what sampling at 100 Hz costs.
</p>
</html>"));
end ScaraContinuousLoop;

within RobotIdentification.FMUs;
block ScaraControllerContinuous "Continuous PD controller of both joints"
  extends Interfaces.TwoJointController;
  Components.ContinuousPD joint_1(
    Kp=Kp_1,
    Kd=Kd_1,
    Tf=Tf,
    tau_max=tau_max_1,
    q_start=q_start_1,
    v_start=v_start_1) "Controller of joint 1";
  Components.ContinuousPD joint_2(
    Kp=Kp_2,
    Kd=Kd_2,
    Tf=Tf,
    tau_max=tau_max_2,
    q_start=q_start_2,
    v_start=v_start_2) "Controller of joint 2";
equation
  connect(qr_1, joint_1.qr);
  connect(qdr_1, joint_1.qdr);
  connect(q_1, joint_1.q);
  connect(qr_2, joint_2.qr);
  connect(qdr_2, joint_2.qdr);
  connect(q_2, joint_2.q);
  connect(joint_1.tau, tau_1);
  connect(joint_2.tau, tau_2);
  annotation (
    experiment(StopTime=1, Interval=0.01),
    Documentation(info="<html>
<p>
Two <a href=\"modelica://RobotIdentification.Components.ContinuousPD\">ContinuousPD</a> controllers: the sampled
controller in the limit of a short sample period.
</p>
</html>"));
end ScaraControllerContinuous;

within RobotIdentification.FMUs;
block ScaraController "Sampled PD controller of both joints, 100 Hz"
  extends Interfaces.TwoJointController;
  parameter Units.Time samplePeriod(min=0)=0.01 "Sample period";
  Components.SampledPD joint_1(
    Kp=Kp_1,
    Kd=Kd_1,
    Tf=Tf,
    tau_max=tau_max_1,
    q_start=q_start_1,
    v_start=v_start_1,
    samplePeriod=samplePeriod) "Controller of joint 1";
  Components.SampledPD joint_2(
    Kp=Kp_2,
    Kd=Kd_2,
    Tf=Tf,
    tau_max=tau_max_2,
    q_start=q_start_2,
    v_start=v_start_2,
    samplePeriod=samplePeriod) "Controller of joint 2";
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
Two <a href=\"modelica://RobotIdentification.Components.SampledPD\">SampledPD</a> controllers with saturation, in
place of the controller that Gautier and Poignet, Control Engineering Practice 9 (2001), do not describe. q_start_i is
the position where the loop starts: the start of the reference. Then the filtered velocity of the first sample is
zero.
</p>
</html>"));
end ScaraController;

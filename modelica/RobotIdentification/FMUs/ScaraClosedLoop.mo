within RobotIdentification.FMUs;
model ScaraClosedLoop "SCARA robot and its sampled PD controller: references in, motion and torques out"
  extends Interfaces.ScaraParameters;
  extends Interfaces.TwoJointGains;
  extends Interfaces.TwoJointStart;
  parameter Units.Time samplePeriod(min=0)=0.01 "Sample period of the controller";
  parameter Units.AngularVelocity v_start_1=0 "Start value of the controller's filtered velocity of joint 1";
  parameter Units.AngularVelocity v_start_2=0 "Start value of the controller's filtered velocity of joint 2";
  Interfaces.RealInput qr_1(unit="rad") "Reference position of joint 1";
  Interfaces.RealInput qr_2(unit="rad") "Reference position of joint 2";
  Interfaces.RealInput qdr_1(unit="rad/s") "Reference velocity of joint 1";
  Interfaces.RealInput qdr_2(unit="rad/s") "Reference velocity of joint 2";
  Interfaces.RealOutput q_1(unit="rad") "Position of joint 1";
  Interfaces.RealOutput q_2(unit="rad") "Position of joint 2, relative to link 1";
  Interfaces.RealOutput qd_1(unit="rad/s") "Velocity of joint 1";
  Interfaces.RealOutput qd_2(unit="rad/s") "Velocity of joint 2";
  Interfaces.RealOutput tau_1(unit="N.m") "Torque of joint 1";
  Interfaces.RealOutput tau_2(unit="N.m") "Torque of joint 2";
  Plants.Scara plant(
    ZZR1=ZZR1,
    Fv1=Fv1,
    Fs1=Fs1,
    ZZ2=ZZ2,
    LMX2=LMX2,
    LMY2=LMY2,
    Fv2=Fv2,
    Fs2=Fs2,
    eps=eps,
    q_start_1=q_start_1,
    q_start_2=q_start_2,
    qd_start_1=qd_start_1,
    qd_start_2=qd_start_2) "Robot";
  ScaraController controller(
    Kp_1=Kp_1,
    Kp_2=Kp_2,
    Kd_1=Kd_1,
    Kd_2=Kd_2,
    Tf=Tf,
    tau_max_1=tau_max_1,
    tau_max_2=tau_max_2,
    samplePeriod=samplePeriod,
    q_start_1=q_start_1,
    q_start_2=q_start_2,
    v_start_1=v_start_1,
    v_start_2=v_start_2) "Controller";
equation
  connect(qr_1, controller.qr_1);
  connect(qr_2, controller.qr_2);
  connect(qdr_1, controller.qdr_1);
  connect(qdr_2, controller.qdr_2);
  connect(plant.q_1, controller.q_1);
  connect(plant.q_2, controller.q_2);
  connect(controller.tau_1, plant.tau_1);
  connect(controller.tau_2, plant.tau_2);
  connect(plant.q_1, q_1);
  connect(plant.q_2, q_2);
  connect(plant.qd_1, qd_1);
  connect(plant.qd_2, qd_2);
  connect(controller.tau_1, tau_1);
  connect(controller.tau_2, tau_2);
  annotation (
    experiment(StopTime=1, Interval=0.01),
    Documentation(info="<html>
<p>
<a href=\"modelica://RobotIdentification.Plants.Scara\">Plants.Scara</a> under
<a href=\"modelica://RobotIdentification.FMUs.ScaraController\">ScaraController</a>: the robot of Gautier and Poignet,
Control Engineering Practice 9 (2001) 1361&ndash;1372, in closed loop. At each sample the controller reads the
position of that instant, and its torque acts from that instant on.
</p>
</html>"));
end ScaraClosedLoop;

within RobotIdentification.FMUs;
model ScaraClosedLoop "SCARA robot and its sampled PD controller: references in, motion and torques out"
  parameter Units.Inertia ZZR1=3.42 "Inertia of link 1, regrouped";
  parameter Units.RotationalDamping Fv1=0.07 "Viscous friction of joint 1";
  parameter Units.Torque Fs1=0.58 "Coulomb friction of joint 1";
  parameter Units.Inertia ZZ2=0.064 "Inertia of link 2 about joint 2";
  parameter Units.Inertia LMX2=0.131 "Length of link 1 times first moment of link 2 along the link";
  parameter Units.Inertia LMY2=0 "Length of link 1 times first moment of link 2 across the link";
  parameter Units.RotationalDamping Fv2=0.015 "Viscous friction of joint 2";
  parameter Units.Torque Fs2=0.156 "Coulomb friction of joint 2";
  parameter Units.AngularVelocity eps(min=0)=0.01 "Width of the smoothed Coulomb friction";
  parameter Units.RotationalStiffness Kp_1=250 "Proportional gain of joint 1";
  parameter Units.RotationalStiffness Kp_2=8 "Proportional gain of joint 2";
  parameter Units.RotationalDamping Kd_1=45 "Derivative gain of joint 1";
  parameter Units.RotationalDamping Kd_2=0.9 "Derivative gain of joint 2";
  parameter Units.Time Tf(min=0)=0.02 "Time constant of the derivative's first-order filter";
  parameter Units.Torque tau_max_1(min=0)=40 "Largest torque of joint 1";
  parameter Units.Torque tau_max_2(min=0)=6 "Largest torque of joint 2";
  parameter Units.Time samplePeriod(min=0)=0.01 "Sample period of the controller";
  parameter Units.Angle q_start_1=0 "Start value of the position of joint 1";
  parameter Units.Angle q_start_2=0 "Start value of the position of joint 2";
  parameter Units.AngularVelocity qd_start_1=0 "Start value of the velocity of joint 1";
  parameter Units.AngularVelocity qd_start_2=0 "Start value of the velocity of joint 2";
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
<a href=\"modelica://RobotIdentification.FMUs.ScaraController\">ScaraController</a>: the robot of Gautier and Poignet, Control
Engineering Practice 9 (2001) 1361&ndash;1372, in closed loop. At each sample the controller reads the position of that instant,
and its torque acts from that instant on.
</p>
</html>"));
end ScaraClosedLoop;

within RobotIdentification.Interfaces;
partial model TwoJointController "Ports and parameters of a joint controller for two revolute joints"
  parameter Units.RotationalStiffness Kp_1=250 "Proportional gain of joint 1";
  parameter Units.RotationalStiffness Kp_2=8 "Proportional gain of joint 2";
  parameter Units.RotationalDamping Kd_1=45 "Derivative gain of joint 1";
  parameter Units.RotationalDamping Kd_2=0.9 "Derivative gain of joint 2";
  parameter Units.Time Tf(min=0)=0.02 "Time constant of the derivative's first-order filter";
  parameter Units.Torque tau_max_1(min=0)=40 "Largest torque of joint 1";
  parameter Units.Torque tau_max_2(min=0)=6 "Largest torque of joint 2";
  parameter Units.Angle q_start_1=0 "Position of joint 1 at the start";
  parameter Units.Angle q_start_2=0 "Position of joint 2 at the start";
  parameter Units.AngularVelocity v_start_1=0 "Filtered velocity of joint 1 at the start";
  parameter Units.AngularVelocity v_start_2=0 "Filtered velocity of joint 2 at the start";
  RealInput qr_1(unit="rad") "Reference position of joint 1";
  RealInput qr_2(unit="rad") "Reference position of joint 2";
  RealInput qdr_1(unit="rad/s") "Reference velocity of joint 1";
  RealInput qdr_2(unit="rad/s") "Reference velocity of joint 2";
  RealInput q_1(unit="rad") "Measured position of joint 1";
  RealInput q_2(unit="rad") "Measured position of joint 2";
  RealOutput tau_1(unit="N.m") "Torque command of joint 1";
  RealOutput tau_2(unit="N.m") "Torque command of joint 2";
  annotation (
    Documentation(info="<html>
<p>References and measured positions in, torques out. The velocity is not measured: a controller differentiates.</p>
</html>"));
end TwoJointController;

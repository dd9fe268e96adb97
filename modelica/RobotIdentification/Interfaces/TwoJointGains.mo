within RobotIdentification.Interfaces;
partial block TwoJointGains "Parameters of a PD controller of two revolute joints"
  parameter Units.RotationalStiffness Kp_1=250 "Proportional gain of joint 1";
  parameter Units.RotationalStiffness Kp_2=8 "Proportional gain of joint 2";
  parameter Units.RotationalDamping Kd_1=45 "Derivative gain of joint 1";
  parameter Units.RotationalDamping Kd_2=0.9 "Derivative gain of joint 2";
  parameter Units.Time Tf(min=0)=0.02 "Time constant of the derivative's first-order filter";
  parameter Units.Torque tau_max_1(min=0)=40 "Largest torque of joint 1";
  parameter Units.Torque tau_max_2(min=0)=6 "Largest torque of joint 2";
  annotation (
    Documentation(info="<html>
<p>
Gains, filter and torque limits of tau = sat(Kp (qr &minus; q) + Kd (qdr &minus; v)), chosen for the SCARA robot.
</p>
</html>"));
end TwoJointGains;

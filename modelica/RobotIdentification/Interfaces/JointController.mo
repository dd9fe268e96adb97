within RobotIdentification.Interfaces;
partial block JointController "Ports and parameters of a PD controller of one revolute joint"
  parameter Units.RotationalStiffness Kp "Proportional gain";
  parameter Units.RotationalDamping Kd "Derivative gain";
  parameter Units.Time Tf(min=0) "Time constant of the derivative's first-order filter";
  parameter Units.Torque tau_max(min=0) "Largest torque";
  parameter Units.Angle q_start "Position at the start";
  parameter Units.AngularVelocity v_start "Filtered velocity at the start";
  RealInput qr(unit="rad") "Reference position";
  RealInput qdr(unit="rad/s") "Reference velocity";
  RealInput q(unit="rad") "Measured position";
  RealOutput tau(unit="N.m") "Torque command, held between the samples of a sampled controller";
  annotation (
    Documentation(info="<html>
<p>
tau = sat(Kp (qr &minus; q) + Kd (qdr &minus; v)), where v is the derivative of q through a first-order filter,
s/(Tf s + 1). How v is computed is left to the block that extends this one.
</p>
</html>"));
end JointController;

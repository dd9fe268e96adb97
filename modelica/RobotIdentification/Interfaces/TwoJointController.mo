within RobotIdentification.Interfaces;
partial block TwoJointController "Ports and parameters of a joint controller for two revolute joints"
  extends TwoJointGains;
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

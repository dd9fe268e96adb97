within RobotIdentification.Interfaces;
partial model TwoJointStart "Start values of two revolute joints"
  parameter Units.Angle q_start_1=0 "Start value of the position of joint 1";
  parameter Units.Angle q_start_2=0 "Start value of the position of joint 2";
  parameter Units.AngularVelocity qd_start_1=0 "Start value of the velocity of joint 1";
  parameter Units.AngularVelocity qd_start_2=0 "Start value of the velocity of joint 2";
  annotation (
    Documentation(info="<html>
<p>Position and velocity of each joint where the simulation starts.</p>
</html>"));
end TwoJointStart;

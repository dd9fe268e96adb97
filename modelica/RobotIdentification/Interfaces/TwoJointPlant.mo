within RobotIdentification.Interfaces;
partial model TwoJointPlant "Ports and start values of a robot with two revolute joints"
  extends TwoJointStart;
  RealInput tau_1(unit="N.m") "Motor torque of joint 1, at the load side";
  RealInput tau_2(unit="N.m") "Motor torque of joint 2, at the load side";
  RealOutput q_1(unit="rad") "Position of joint 1";
  RealOutput q_2(unit="rad") "Position of joint 2, relative to link 1";
  RealOutput qd_1(unit="rad/s") "Velocity of joint 1";
  RealOutput qd_2(unit="rad/s") "Velocity of joint 2";
  annotation (
    Documentation(info="<html>
<p>Torques in, positions and velocities out. A plant extends this and says how the torques move the joints.</p>
</html>"));
end TwoJointPlant;

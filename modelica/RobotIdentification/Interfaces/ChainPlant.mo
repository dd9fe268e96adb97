within RobotIdentification.Interfaces;
partial model ChainPlant "Ports and start values of a robot with n revolute joints"
  extends ChainStart;
  RealInput tau[n](each unit="N.m") "Motor torque of each joint, at the load side";
  RealOutput q[n](each unit="rad") "Position of each joint, relative to the link before it";
  RealOutput qd[n](each unit="rad/s") "Velocity of each joint";
  annotation (
    Documentation(info="<html>
<p>Torques in, positions and velocities out. A plant extends this and says how the torques move the joints.</p>
</html>"));
end ChainPlant;

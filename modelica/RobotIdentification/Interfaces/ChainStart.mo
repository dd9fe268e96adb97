within RobotIdentification.Interfaces;
partial model ChainStart "Number and start values of the revolute joints of a chain"
  parameter Integer n(min=1) "Number of joints";
  parameter Units.Angle q_start[n]=fill(0, n) "Start value of the position of each joint";
  parameter Units.AngularVelocity qd_start[n]=fill(0, n) "Start value of the velocity of each joint";
  annotation (
    Documentation(info="<html>
<p>Position and velocity of each joint where the simulation starts: by default the chain hangs, at rest.</p>
</html>"));
end ChainStart;

within RobotIdentification.Interfaces;
partial model OneJointDrive "Ports and start values of a drive with one prismatic joint"
  extends OneJointStart;
  RealInput u(unit="V") "Drive command";
  RealOutput q(unit="m") "Position, motor side reduced to the load";
  RealOutput qd(unit="m/s") "Velocity";
  annotation (
    Documentation(info="<html>
<p>The drive command in volts in, position and velocity out.</p>
</html>"));
end OneJointDrive;

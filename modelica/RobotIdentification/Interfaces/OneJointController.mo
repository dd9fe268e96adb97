within RobotIdentification.Interfaces;
partial block OneJointController "Ports and start values of a position controller of one prismatic joint"
  parameter Units.Position q_start=0 "Position at the first sample";
  parameter Units.Velocity qd_start=0 "Velocity at the first sample and before";
  RealInput qr(unit="m") "Reference position";
  RealInput pulse(unit="V") "Voltage added to the command, inside the limit";
  RealInput q(unit="m") "Measured position";
  RealOutput u(unit="V") "Drive command, held between the samples";
  annotation (
    Documentation(info="<html>
<p>
Reference, pulse and measured position in, drive command out. The velocity is not measured: a controller
differentiates.
</p>
</html>"));
end OneJointController;

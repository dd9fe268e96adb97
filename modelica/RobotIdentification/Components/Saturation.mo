within RobotIdentification.Components;
block Saturation "Symmetric limit of a torque, without an event"
  parameter Units.Torque y_max(min=0) "Largest magnitude of the output";
  Interfaces.RealInput u(unit="N.m") "Torque to be limited";
  Interfaces.RealOutput y(unit="N.m") "Limited torque";
equation
  y = max(-y_max, min(y_max, u));
  annotation (
    Documentation(info="<html>
<p>y = u inside &plusmn;y_max, and the limit outside.</p>
</html>"));
end Saturation;

within RobotIdentification;
package Units "SI unit types (in the manner of Modelica.Units.SI, so that no other library is needed)"
  type Time = Real(final quantity="Time", final unit="s") "Time";
  type Angle = Real(final quantity="Angle", final unit="rad", displayUnit="deg") "Angle";
  type AngularVelocity = Real(final quantity="AngularVelocity", final unit="rad/s") "Angular velocity";
  type AngularAcceleration = Real(final quantity="AngularAcceleration", final unit="rad/s2") "Angular acceleration";
  type Torque = Real(final quantity="Torque", final unit="N.m") "Torque";
  type Inertia = Real(final quantity="MomentOfInertia", final unit="kg.m2")
    "Moment of inertia, or a first moment times a length";
  type FirstMoment = Real(final quantity="FirstMoment", final unit="kg.m") "First moment of a mass";
  type RotationalDamping = Real(final quantity="RotationalDampingConstant", final unit="N.m.s/rad")
    "Torque per angular velocity";
  type RotationalStiffness = Real(final quantity="RotationalSpringConstant", final unit="N.m/rad") "Torque per angle";
  type Position = Real(final quantity="Length", final unit="m") "Position along an axis, or a length";
  type Velocity = Real(final quantity="Velocity", final unit="m/s") "Velocity";
  type Acceleration = Real(final quantity="Acceleration", final unit="m/s2") "Acceleration";
  type Mass = Real(final quantity="Mass", final unit="kg") "Mass";
  type Force = Real(final quantity="Force", final unit="N") "Force";
  type TranslationalDamping = Real(final quantity="TranslationalDampingConstant", final unit="N.s/m")
    "Force per velocity";
  type Voltage = Real(final quantity="ElectricPotential", final unit="V") "Drive command";
  type DriveGain = Real(final quantity="DriveGain", final unit="N/V") "Force per volt of the drive command";
  type PositionGain = Real(final quantity="PositionGain", final unit="1/s") "Velocity per position error";
  type VelocityGain = Real(final quantity="VelocityGain", final unit="V.s/m") "Volt per velocity error";
  annotation (
    Documentation(info="<html>
<p>
Types with quantity and unit for every declaration of the package. Names, quantities and the spelling of the units
follow the Modelica Standard Library; gains that it has no type for are added at the end.
</p>
</html>"));
end Units;

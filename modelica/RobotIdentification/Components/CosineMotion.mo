within RobotIdentification.Components;
block CosineMotion "Reference of a revolute joint that swings from rest: position and velocity"
  parameter Units.Angle amplitude "Half of the swing";
  parameter Units.Time period(min=0) "Duration of one swing forth and back";
  Interfaces.RealOutput qr(unit="rad") "Reference position";
  Interfaces.RealOutput qdr(unit="rad/s") "Reference velocity";
protected
  constant Real pi(final unit="1")=3.141592653589793 "Ratio of circumference to diameter";
  parameter Units.AngularVelocity w=2*pi/period "Angular frequency of the swing";
equation
  qr = amplitude*(1 - cos(w*time));
  qdr = amplitude*w*sin(w*time);
  annotation (
    Documentation(info="<html>
<p>qr = amplitude (1 &minus; cos(2 &pi; t/period)), which starts at 0 with velocity 0, and its derivative.</p>
</html>"));
end CosineMotion;

within RobotIdentification.Components;
block CosineSlide "Reference of a prismatic joint that moves forth and back from rest"
  parameter Units.Position amplitude "Half of the stroke";
  parameter Units.Time period(min=0) "Duration of one stroke forth and back";
  Interfaces.RealOutput qr(unit="m") "Reference position";
protected
  constant Real pi(final unit="1")=3.141592653589793 "Ratio of circumference to diameter";
equation
  qr = amplitude*(1 - cos(2*pi*time/period));
  annotation (
    Documentation(info="<html>
<p>qr = amplitude (1 &minus; cos(2 &pi; t/period)), which starts at 0 with velocity 0.</p>
</html>"));
end CosineSlide;

within RobotIdentification.Components;
block SlideFriction "Viscous and smoothed Coulomb friction of a prismatic joint"
  parameter Units.TranslationalDamping Fv "Viscous friction";
  parameter Units.Force Fc "Coulomb friction";
  parameter Units.Velocity eps(min=0) "Width of the smoothed sign function";
  Interfaces.RealInput qd(unit="m/s") "Velocity of the joint";
  Interfaces.RealOutput F(unit="N") "Friction force, against the motion";
equation
  F = Fv*qd + Fc*tanh(qd/eps);
  annotation (
    Documentation(info="<html>
<p>
F = Fv qd + Fc sign(qd), as in the inverse model of the EMPS benchmark (A. Janot, M. Gautier, M. Brunot), with sign(qd)
smoothed to tanh(qd/eps).
</p>
</html>"));
end SlideFriction;

within RobotIdentification.Interfaces;
partial model ChainParameters "Base parameters of a planar chain of n links"
  extends ChainStart;
  parameter Units.Inertia ZZ[n]={0.5*(1/3 + n - i) for i in 1:n} "Inertia of each link about its joint, regrouped";
  parameter Units.FirstMoment MX[n]={0.5 + n - i for i in 1:n} "First moment of each link along the link, regrouped";
  parameter Units.RotationalDamping Fv[n]=fill(0.1, n) "Viscous friction of each joint";
  parameter Units.Torque Fs[n]=fill(0.2, n) "Coulomb friction of each joint";
  parameter Units.Position L[n]=fill(0.5, n) "Length of each link, from its joint to the next one";
  parameter Units.Acceleration g=9.81 "Gravity";
  parameter Units.AngularVelocity eps(min=0)=0.1 "Width of the smoothed Coulomb friction";
  annotation (
    Documentation(info="<html>
<p>
Four parameters per link are to be identified: ZZ, MX, Fv and Fs. The values are those of n slender rods of m = 2 kg
and L = 0.5 m each: with the rods behind it regrouped, ZZ[i] = m L<sup>2</sup> (1/3 + n &minus; i) and MX[i] = m L
(1/2 + n &minus; i). Rods that exist have a positive definite mass matrix, however many there are.
</p>
</html>"));
end ChainParameters;

within RobotIdentification.Interfaces;
partial model ScaraParameters "Base parameters of the two-joint SCARA robot"
  parameter Units.Inertia ZZR1=3.42 "Inertia of link 1, regrouped";
  parameter Units.RotationalDamping Fv1=0.07 "Viscous friction of joint 1";
  parameter Units.Torque Fs1=0.58 "Coulomb friction of joint 1";
  parameter Units.Inertia ZZ2=0.064 "Inertia of link 2 about joint 2";
  parameter Units.Inertia LMX2=0.131 "Length of link 1 times first moment of link 2 along the link";
  parameter Units.Inertia LMY2=0 "Length of link 1 times first moment of link 2 across the link";
  parameter Units.RotationalDamping Fv2=0.015 "Viscous friction of joint 2";
  parameter Units.Torque Fs2=0.156 "Coulomb friction of joint 2";
  parameter Units.AngularVelocity eps(min=0)=0.01 "Width of the smoothed Coulomb friction";
  annotation (
    Documentation(info="<html>
<p>
The eight base parameters of Gautier and Poignet, Control Engineering Practice 9 (2001) 1361&ndash;1372, in the
paper's order; the values are its a-priori column, which is the truth of the simulated robot.
</p>
</html>"));
end ScaraParameters;

within RobotIdentification.Components;
block JointFriction "Viscous and smoothed Coulomb friction of a revolute joint"
  parameter Units.RotationalDamping Fv "Viscous friction";
  parameter Units.Torque Fs "Coulomb friction";
  parameter Units.AngularVelocity eps(min=0) "Width of the smoothed sign function";
  Interfaces.RealInput qd(unit="rad/s") "Velocity of the joint";
  Interfaces.RealOutput tau(unit="N.m") "Friction torque, against the motion";
equation
  tau = Fv*qd + Fs*tanh(qd/eps);
  annotation (
    Documentation(info="<html>
<p>
tau = Fv qd + Fs sign(qd), Gautier and Poignet, Control Engineering Practice 9 (2001), Eq. 1, with sign(qd) smoothed to
tanh(qd/eps), so that neither a state event nor a Jacobian ends at a reversal. (The text of the paper names the two
parameters the wrong way round: Fv is the viscous one, Fs the Coulomb one.)
</p>
</html>"));
end JointFriction;

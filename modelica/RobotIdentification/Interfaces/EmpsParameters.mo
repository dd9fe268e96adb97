within RobotIdentification.Interfaces;
partial model EmpsParameters "Parameters of the EMPS drive"
  parameter Units.Mass M=95 "Equivalent moving mass";
  parameter Units.TranslationalDamping Fv=200 "Viscous friction";
  parameter Units.Force Fc=20 "Coulomb friction";
  parameter Units.Force offset=-3 "Constant force of drive and friction asymmetry";
  parameter Units.Velocity eps(min=0)=1e-3 "Width of the smoothed Coulomb friction";
  parameter Units.DriveGain G=1 "Drive gain; neutral here, its value is given where the model is used";
  annotation (
    Documentation(info="<html>
<p>
The four parameters of the EMPS benchmark (A. Janot, M. Gautier, M. Brunot); the values are the published result,
rounded, as an a-priori guess. The drive gain G is not a number of this library: it belongs to the drive that is
recorded, and is given with its binding.
</p>
</html>"));
end EmpsParameters;

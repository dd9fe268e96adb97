within RobotIdentification.Plants;
model Emps "Electro-mechanical positioning system: one prismatic joint, ball screw and DC motor"
  extends Interfaces.OneJointDrive;
  extends Interfaces.EmpsParameters;
  Units.Position x(start=q_start, fixed=true) "Position";
  Units.Velocity v(start=qd_start, fixed=true) "Velocity";
  Units.Force F "Force of the drive";
  Components.SlideFriction friction(
    Fv=Fv,
    Fc=Fc,
    eps=eps) "Friction of the joint";
equation
  F = G*u;
  der(x) = v;
  M*der(v) = F - friction.F - offset;
  friction.qd = v;
  q = x;
  qd = v;
  annotation (
    Documentation(info="<html>
<p>
The inverse model of the EMPS benchmark (A. Janot, M. Gautier, M. Brunot: <i>Data set and reference models of EMPS</i>,
Workshop on Nonlinear System Identification Benchmarks, 2019):
</p>
<pre>
G u = M qdd + Fv qd + Fc sign(qd) + offset
</pre>
<p>
with sign(qd) smoothed to tanh(qd/eps). The default values are the published ones, rounded, as an a-priori guess. The
drive gain G is not a number of this library: it belongs to the drive that is recorded, and is given with its binding.
</p>
</html>"));
end Emps;

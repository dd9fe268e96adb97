within RobotIdentification.Plants;
model Chain "Planar chain of n links in its 4 n base parameters"
  extends Interfaces.ChainPlant;
  extends Interfaces.ChainParameters;
  Components.ChainBody body(
    n=n,
    ZZ=ZZ,
    MX=MX,
    L=L,
    g=g,
    q_start=q_start,
    qd_start=qd_start) "All links";
  Components.JointFriction friction[n](
    Fv=Fv,
    Fs=Fs,
    each eps=eps) "Friction of each joint";
equation
  q = body.q;
  qd = body.qd;
  friction.qd = body.qd;
  body.tau = tau - friction.tau;
  annotation (
    Documentation(info="<html>
<p>
A robot with as many joints as one likes, to see how identification scales: n links that move in a vertical plane
(<a href=\"modelica://RobotIdentification.Components.ChainBody\">ChainBody</a>) and joint friction. Its inverse model is
linear in the 4 n parameters ZZ, MX, Fv and Fs; lengths and gravity are known. n has no default: whoever extends this
gives it a value, and the size of every array follows.
</p>
</html>"));
end Chain;

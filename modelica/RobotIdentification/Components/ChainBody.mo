within RobotIdentification.Components;
model ChainBody "Rigid-body dynamics of n links that move in a vertical plane"
  extends Interfaces.ChainStart;
  parameter Units.Inertia ZZ[n] "Inertia of each link about its joint, regrouped";
  parameter Units.FirstMoment MX[n] "First moment of each link along the link, regrouped";
  parameter Units.Position L[n] "Length of each link, from its joint to the next one";
  parameter Units.Acceleration g "Gravity";
  Interfaces.RealInput tau[n](each unit="N.m") "Torque on each joint, friction taken off";
  Units.Angle q[n](start=q_start, each fixed=true) "Position of each joint";
  Units.AngularVelocity qd[n](start=qd_start, each fixed=true) "Velocity of each joint";
  Units.AngularAcceleration qdd[n] "Acceleration of each joint";
  Units.Angle theta[n] "Angle of each link, 0 where it hangs";
  Units.AngularVelocity omega[n] "Angular velocity of each link";
  Units.AngularAcceleration omegad[n] "Angular acceleration of each link";
  Real c[n](each unit="1") "Cosine of theta";
  Real s[n](each unit="1") "Sine of theta";
equation
  der(q) = qd;
  der(qd) = qdd;
  theta[1] = q[1];
  omega[1] = qd[1];
  omegad[1] = qdd[1];
  for i in 2:n loop
    theta[i] = theta[i - 1] + q[i];
    omega[i] = omega[i - 1] + qd[i];
    omegad[i] = omegad[i - 1] + qdd[i];
  end for;
  c = cos(theta);
  s = sin(theta);
  {{if i == j then ZZ[i] else L[min(i, j)]*MX[max(i, j)]*(c[i]*c[j] + s[i]*s[j]) for j in 1:n} for i in 1:n}*omegad
    + {{if i == j then 0 else L[min(i, j)]*MX[max(i, j)]*(s[i]*c[j] - c[i]*s[j]) for j in 1:n} for i in 1:n}*omega.^2
    + g*MX.*s = {if i < n then tau[i] - tau[i + 1] else tau[i] for i in 1:n};
  annotation (
    Documentation(info="<html>
<p>
The direct dynamic model of a planar chain in its base parameters, from Lagrange's equations in the angles of the
links, theta[i] = q[1] + &hellip; + q[i]: in these the mass matrix is simpler and better conditioned than in the
joints' angles. Link k has the mass m[k], the first moment mX[k] along itself, none across, and the inertia J[k] about
its joint. What the mass of the links behind it adds to a link is regrouped (M. Gautier and W. Khalil, <i>Direct
calculation of minimum set of inertial parameters of serial robots</i>, IEEE Transactions on Robotics and Automation 6
(1990) 368&ndash;373):
</p>
<pre>
ZZ[i] = J[i]  + L[i]^2 (m[i+1] + ... + m[n])
MX[i] = mX[i] + L[i] (m[i+1] + ... + m[n])
</pre>
<p>
With omega = der(theta) and sums over i, and over the pairs j &gt; i, the kinetic and the potential energy are
</p>
<pre>
T = sum ZZ[i] omega[i]^2 / 2 + sum L[i] MX[j] cos(theta[j] - theta[i]) omega[i] omega[j]
V = -g sum MX[i] cos(theta[i])
</pre>
<p>
and d/dt(dT/domega[i]) &minus; dT/dtheta[i] + dV/dtheta[i] is the torque on link i: that of its own joint, less that of
the next one. With a = min(i, j), b = max(i, j) and sums over j this is
</p>
<pre>
M[i, i] = ZZ[i],   M[i, j] = L[a] MX[b] cos(theta[i] - theta[j])
sum M[i, j] der(omega[j]) + sum L[a] MX[b] sin(theta[i] - theta[j]) omega[j]^2 + g MX[i] sin(theta[i])
    = tau[i] - tau[i+1]
</pre>
<p>
Cosine and sine of the differences are written in c and s, so that 2 n of them are computed instead of n (n &minus; 1).
Two links without gravity are the SCARA of
<a href=\"modelica://RobotIdentification.Components.TwoLinkBody\">TwoLinkBody</a> with ZZR1 = ZZ[1], ZZ2 = ZZ[2],
LMX2 = L[1] MX[2] and LMY2 = 0.
</p>
</html>"));
end ChainBody;

within RobotIdentification.Components;
model TwoLinkBody "Rigid-body dynamics of two links that move in a horizontal plane"
  extends Interfaces.TwoJointStart;
  parameter Units.Inertia ZZR1 "Inertia of link 1, regrouped: rotor, and mass of link 2 at the elbow, included";
  parameter Units.Inertia ZZ2 "Inertia of link 2 about joint 2";
  parameter Units.Inertia LMX2 "Length of link 1 times first moment of link 2 along the link";
  parameter Units.Inertia LMY2 "Length of link 1 times first moment of link 2 across the link";
  Interfaces.RealInput tau_1(unit="N.m") "Torque on joint 1, friction taken off";
  Interfaces.RealInput tau_2(unit="N.m") "Torque on joint 2, friction taken off";
  Units.Angle q_1(start=q_start_1, fixed=true) "Position of joint 1";
  Units.Angle q_2(start=q_start_2, fixed=true) "Position of joint 2";
  Units.AngularVelocity qd_1(start=qd_start_1, fixed=true) "Velocity of joint 1";
  Units.AngularVelocity qd_2(start=qd_start_2, fixed=true) "Velocity of joint 2";
  Units.AngularAcceleration qdd_1 "Acceleration of joint 1";
  Units.AngularAcceleration qdd_2 "Acceleration of joint 2";
  Units.Inertia a "Coupling of the accelerations, half of what link 2's pose adds to the inertia of joint 1";
  Units.Inertia b "Coupling of the velocities, minus da/dq_2";
equation
  a = LMX2*cos(q_2) - LMY2*sin(q_2);
  b = LMX2*sin(q_2) + LMY2*cos(q_2);
  der(q_1) = qd_1;
  der(q_2) = qd_2;
  der(qd_1) = qdd_1;
  der(qd_2) = qdd_2;
  (ZZR1 + ZZ2 + 2*a)*qdd_1 + (ZZ2 + a)*qdd_2 = tau_1 + b*qd_2*(2*qd_1 + qd_2);
  (ZZ2 + a)*qdd_1 + ZZ2*qdd_2 = tau_2 - b*qd_1*qd_1;
  annotation (
    Documentation(info="<html>
<p>
The direct dynamic model M(q) qdd = tau &minus; C(q, qd) of the two-joint SCARA robot in its base parameters, Gautier
and Poignet, Control Engineering Practice 9 (2001) 1361&ndash;1372, derived again from Lagrange's equations. With a =
LMX2 cos q2 &minus; LMY2 sin q2:
</p>
<pre>
M11 = ZZR1 + ZZ2 + 2 a,   M12 = ZZ2 + a,   M22 = ZZ2
</pre>
<p>
Two printing errors of the paper's inverse model are corrected: the last factor of the LMY2 term in row 1 is cos q2,
not sin q2, and row 2 has lost a zero. The printed direct model is right. M is positive definite as long as ZZR1 ZZ2
&gt; LMX2<sup>2</sup> + LMY2<sup>2</sup>, which no <code>min</code> can say; whoever changes the parameters watches
it. The joints move in a horizontal plane: no gravity.
</p>
</html>"));
end TwoLinkBody;

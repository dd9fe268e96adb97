within RobotIdentification.Plants;
model Scara "Two-joint SCARA robot in its eight base parameters"
  extends Interfaces.TwoJointPlant;
  extends Interfaces.ScaraParameters;
  Components.TwoLinkBody body(
    ZZR1=ZZR1,
    ZZ2=ZZ2,
    LMX2=LMX2,
    LMY2=LMY2,
    q_start_1=q_start_1,
    q_start_2=q_start_2,
    qd_start_1=qd_start_1,
    qd_start_2=qd_start_2) "Both links";
  Components.JointFriction friction_1(
    Fv=Fv1,
    Fs=Fs1,
    eps=eps) "Friction of joint 1";
  Components.JointFriction friction_2(
    Fv=Fv2,
    Fs=Fs2,
    eps=eps) "Friction of joint 2";
equation
  q_1 = body.q_1;
  q_2 = body.q_2;
  qd_1 = body.qd_1;
  qd_2 = body.qd_2;
  friction_1.qd = body.qd_1;
  friction_2.qd = body.qd_2;
  body.tau_1 = tau_1 - friction_1.tau;
  body.tau_2 = tau_2 - friction_2.tau;
  annotation (
    Documentation(info="<html>
<p>
The two-joint robot of M. Gautier and Ph. Poignet, Control Engineering Practice 9 (2001) 1361&ndash;1372: rigid body
dynamics (<a href=\"modelica://RobotIdentification.Components.TwoLinkBody\">TwoLinkBody</a>) and joint friction. The
default values are the paper's a-priori column, which is the truth of the simulated robot. The paper's inverse model
tau = D(q, qd, qdd) chi is linear in the eight parameters; this is its direct form.
</p>
</html>"));
end Scara;

within RobotIdentification.Components;
block ContinuousPD "Continuous PD controller with filtered derivative and saturation"
  extends Interfaces.JointController;
  Units.Angle q_f(start=q_start - Tf*v_start, fixed=true) "Position behind the first-order filter";
  Units.AngularVelocity v "Filtered velocity";
  Saturation saturation(y_max=tau_max) "Limit of the torque";
equation
  Tf*v = q - q_f;
  der(q_f) = v;
  saturation.u = Kp*(qr - q) + Kd*(qdr - v);
  connect(saturation.y, tau);
  annotation (
    Documentation(info="<html>
<p>
tau = sat(Kp (qr &minus; q) + Kd (qdr &minus; v)) with V(s) = s/(Tf s + 1) Q(s), written with the filtered position
q_f as state. The start value gives v(0) = v_start where q(0) = q_start.
</p>
</html>"));
end ContinuousPD;

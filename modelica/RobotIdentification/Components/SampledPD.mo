within RobotIdentification.Components;
block SampledPD "Sampled PD controller with filtered derivative and saturation"
  extends Interfaces.JointController;
  parameter Units.Time samplePeriod(min=0) "Sample period";
  discrete Units.Angle q_k(start=q_start, fixed=true) "Position at the last sample";
  discrete Units.AngularVelocity v(start=v_start, fixed=true) "Filtered velocity at the last sample";
equation
  when sample(0, samplePeriod) then
    q_k = q;
    v = (Tf*pre(v) + q - pre(q_k))/(Tf + samplePeriod);
    tau = max(-tau_max, min(tau_max, Kp*(qr - q) + Kd*(qdr - v)));
  end when;
  annotation (
    Documentation(info="<html>
<p>
tau = sat(Kp (qr &minus; q) + Kd (qdr &minus; v)), held until the next sample. The velocity is the backward Euler form
of s/(Tf s + 1):
</p>
<pre>
v(k) = (Tf v(k-1) + q(k) - q(k-1))/(Tf + samplePeriod)
</pre>
<p>
Before the first sample q(&minus;1) = q_start and v(&minus;1) = v_start: a loop that starts at rest at q_start begins
with v(0) = 0.
</p>
</html>"));
end SampledPD;

within RobotIdentification.Components;
block TwoLoopController "Sampled two-loop position controller of the EMPS drive"
  extends Interfaces.OneJointController;
  extends Interfaces.TwoLoopGains;
  parameter Units.Time samplePeriod(min=0)=0.001 "Sample period";
  discrete Units.Position q_k(start=q_start - samplePeriod*qd_start, fixed=true) "Position at the last sample";
  discrete Units.Position q_f(start=q_start - 1.5*samplePeriod*qd_start, fixed=true)
    "Mean of the last two positions";
  discrete Units.Velocity v(start=qd_start, fixed=true) "Velocity, the difference of two such means";
equation
  when sample(0, samplePeriod) then
    q_k = q;
    q_f = (q + pre(q_k))/2;
    v = (q_f - pre(q_f))/samplePeriod;
    u = max(-u_max, min(u_max, kp*kv*(qr - q) - kv*v + pulse));
  end when;
  annotation (
    Documentation(info="<html>
<p>
The published controller of the EMPS benchmark (A. Janot, M. Gautier, M. Brunot), at 1 kHz:
</p>
<pre>
q_f(k) = (q(k) + q(k-1))/2
v(k)   = (q_f(k) - q_f(k-1))/samplePeriod
u(k)   = sat(kp kv (qr(k) - q(k)) - kv v(k) + pulse(k))
</pre>
<p>
Two points the publication leaves open were settled on its measured data, by feeding the measured positions to these
equations and comparing u with the recorded command:
</p>
<ul>
<li>The pulse enters <b>before</b> the limit. In the run with pulses 14 samples have |u| &gt; 10 V without the pulse
and less than 10 V with it; there the recorded command differs from sat(&hellip; + pulse) by at most 0.015 V, and from
sat(&hellip;) + pulse by up to 0.91 V. The height of the pulse is 5.069 V.</li>
<li>At the first recorded sample the drive is already moving, so the past of the controller is that of a constant
velocity: q(&minus;1) = q_start &minus; samplePeriod qd_start, q(&minus;2) = q_start &minus; 2 samplePeriod qd_start.
The first two recorded commands give qd_start = 0.0056 m/s; started from rest, the first command is 1.4 V too large,
with qd_start 0.04 V remain at the second sample and 0.004 V (rms) from there on.</li>
</ul>
</html>"));
end TwoLoopController;

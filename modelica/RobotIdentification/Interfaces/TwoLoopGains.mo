within RobotIdentification.Interfaces;
partial block TwoLoopGains "Parameters of the two-loop position controller"
  parameter Units.PositionGain kp=160.18 "Gain of the position loop";
  parameter Units.VelocityGain kv=243.45 "Gain of the velocity loop";
  parameter Units.Voltage u_max(min=0)=10 "Largest drive command";
  annotation (
    Documentation(info="<html>
<p>Gains and limit as published with the EMPS benchmark (A. Janot, M. Gautier, M. Brunot).</p>
</html>"));
end TwoLoopGains;

within RobotIdentification.FMUs;
model EmpsClosedLoop "EMPS drive and its two-loop controller: reference and pulse in, motion and command out"
  extends Interfaces.EmpsParameters;
  extends Interfaces.TwoLoopGains;
  extends Interfaces.OneJointStart;
  parameter Units.Time samplePeriod(min=0)=0.001 "Sample period of the controller";
  Interfaces.RealInput qr(unit="m") "Reference position";
  Interfaces.RealInput pulse(unit="V") "Voltage added to the command, inside the limit";
  Interfaces.RealOutput q(unit="m") "Position";
  Interfaces.RealOutput qd(unit="m/s") "Velocity";
  Interfaces.RealOutput u(unit="V") "Drive command";
  Plants.Emps plant(
    M=M,
    Fv=Fv,
    Fc=Fc,
    offset=offset,
    eps=eps,
    G=G,
    q_start=q_start,
    qd_start=qd_start) "Drive";
  Components.TwoLoopController controller(
    kp=kp,
    kv=kv,
    u_max=u_max,
    samplePeriod=samplePeriod,
    q_start=q_start,
    qd_start=qd_start) "Controller";
equation
  connect(qr, controller.qr);
  connect(pulse, controller.pulse);
  connect(plant.q, controller.q);
  connect(controller.u, plant.u);
  connect(plant.q, q);
  connect(plant.qd, qd);
  connect(controller.u, u);
  annotation (
    experiment(StopTime=1, Interval=0.001),
    Documentation(info="<html>
<p>
<a href=\"modelica://RobotIdentification.Plants.Emps\">Plants.Emps</a> under
<a href=\"modelica://RobotIdentification.Components.TwoLoopController\">TwoLoopController</a>: the EMPS benchmark of A.
Janot, M. Gautier and M. Brunot in closed loop. Plant and controller start from the same position and velocity.
</p>
</html>"));
end EmpsClosedLoop;

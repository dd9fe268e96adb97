within RobotIdentification.Interfaces;
partial model OneJointStart "Start values of one prismatic joint"
  parameter Units.Position q_start=0 "Start value of the position";
  parameter Units.Velocity qd_start=0 "Start value of the velocity";
  annotation (
    Documentation(info="<html>
<p>Position and velocity where the simulation starts.</p>
</html>"));
end OneJointStart;

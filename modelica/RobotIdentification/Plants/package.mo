within RobotIdentification;
package Plants "Plants: what is identified"
  annotation (
    Documentation(info="<html>
<p>Physical models only: no sensor, no controller, no disturbance.</p>
</html>"));
end Plants;

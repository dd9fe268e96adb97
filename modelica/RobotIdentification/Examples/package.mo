within RobotIdentification;
package Examples "Closed loops that run by themselves"
  annotation (
    Documentation(info="<html>
<p>Each example carries its own reference signal and an <code>experiment</code> annotation: load, simulate, plot.</p>
</html>"));
end Examples;

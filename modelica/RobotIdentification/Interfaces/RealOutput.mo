within RobotIdentification.Interfaces;
connector RealOutput = output Real "Output signal; its unit is given where it is declared"
  annotation (
    Documentation(info="<html>
<p>Connector with one output signal, as in the blocks of the Modelica Standard Library.</p>
</html>"));

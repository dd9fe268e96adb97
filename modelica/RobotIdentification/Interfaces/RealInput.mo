within RobotIdentification.Interfaces;
connector RealInput = input Real "Input signal; its unit is given where it is declared"
  annotation (
    Documentation(info="<html>
<p>Connector with one input signal, as in the blocks of the Modelica Standard Library.</p>
</html>"));

within RobotIdentification;
package Interfaces "Connectors and partial models that plants and controllers extend"
  annotation (
    Documentation(info="<html>
<p>Ports are scalar signals in SI units: what is partial here is what an FMU of that kind offers to the outside.</p>
</html>"));
end Interfaces;

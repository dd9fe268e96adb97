within RobotIdentification;
package FMUs "Models that are exported as Functional Mock-up Units"
  annotation (
    Documentation(info="<html>
<p>
Every class of this package becomes one FMU; its file name is the name of the class in snake_case. Ports are scalar,
and the parameters to be identified stand at the top level under the names of the literature.
</p>
</html>"));
end FMUs;

within RobotIdentification;
package Benchmarks "Models of growing size, exported when they are asked for by name"
  annotation (
    Documentation(info="<html>
<p>
One plant in several sizes, to measure how the cost of a filter grows with the number of joints. Like those of
<a href=\"modelica://RobotIdentification.FMUs\">FMUs</a> every class can become an FMU, whose file name is the name of
the class in snake_case; but only by its name, for the larger ones take a while to compile.
</p>
</html>"));
end Benchmarks;

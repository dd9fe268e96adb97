within RobotIdentification;
package Components "Parts of plants and controllers"
  annotation (
    Documentation(info="<html>
<p>Each component is one equation of the sources named in its documentation.</p>
</html>"));
end Components;

package RobotIdentification "Robots, drives and their controllers, for the identification of physical parameters"
  annotation (
    version="1.0.0",
    Documentation(info="<html>
<p>
Plants whose inverse model is linear in the parameters to be identified, the controllers they are recorded under,
and the closed loops of both.
</p>
<ul>
<li><b>SCARA</b>: the two-joint robot of M. Gautier and Ph. Poignet, <i>Extended Kalman filtering and weighted least
squares dynamic identification of robot</i>, Control Engineering Practice 9 (2001) 1361&ndash;1372, with its eight base
parameters.</li>
<li><b>EMPS</b>: the electro-mechanical positioning system, one prismatic joint, published with measured data by
A. Janot, M. Gautier and M. Brunot as a benchmark of nonlinear system identification.</li>
</ul>
<p>
The package needs no other library. Every declaration is in SI units. Parameters that an estimator may change carry no
<code>min</code>: a filter may ask for a negative friction on its way, and the model has to answer.
</p>
</html>"));
end RobotIdentification;

// Half of a triaxial specimen, axisymmetric: radius 25 mm (x), half height 50 mm (y), 2 x 4 quadrilaterals. Metres.
r = 0.025; h = 0.050;
Point(1) = {0, 0, 0}; Point(2) = {r, 0, 0}; Point(3) = {r, h, 0}; Point(4) = {0, h, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Transfinite Curve {1, 3} = 3; Transfinite Curve {2, 4} = 5;
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Surface {1}; Recombine Surface {1};
Physical Curve("middle", 1) = {1}; Physical Curve("membrane", 2) = {2}; Physical Curve("platen", 3) = {3}; Physical Curve("axis", 4) = {4};
Physical Surface("sand", 10) = {1};

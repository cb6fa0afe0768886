// Split Hopkinson bar, axisymmetric: x is the radius, y the axis. Bars of 12.7 mm diameter, 1.5 m (incident) and 1.2 m
// (transmission), a specimen of the same diameter and 6 mm length between them. Metres.
r = 0.00635; Li = 1.500; Ls = 0.006; Lt = 1.200;
Point(1) = {0, 0, 0}; Point(2) = {r, 0, 0};
Point(3) = {0, Li, 0}; Point(4) = {r, Li, 0};
Point(5) = {0, Li + Ls, 0}; Point(6) = {r, Li + Ls, 0};
Point(7) = {0, Li + Ls + Lt, 0}; Point(8) = {r, Li + Ls + Lt, 0};
Line(1) = {1, 2}; Line(2) = {3, 4}; Line(3) = {5, 6}; Line(4) = {7, 8};
Line(11) = {1, 3}; Line(12) = {2, 4}; Line(13) = {3, 5}; Line(14) = {4, 6}; Line(15) = {5, 7}; Line(16) = {6, 8};
Transfinite Curve {1, 2, 3, 4} = 3;
Transfinite Curve {11, 12} = 301; Transfinite Curve {13, 14} = 3; Transfinite Curve {15, 16} = 241;
Curve Loop(1) = {1, 12, -2, -11}; Plane Surface(1) = {1};
Curve Loop(2) = {2, 14, -3, -13}; Plane Surface(2) = {2};
Curve Loop(3) = {3, 16, -4, -15}; Plane Surface(3) = {3};
Transfinite Surface {1, 2, 3}; Recombine Surface {1, 2, 3};
Physical Curve("impact", 1) = {1}; Physical Curve("end", 2) = {4}; Physical Curve("axis", 3) = {11, 13, 15}; Physical Curve("jacket", 4) = {14};
Physical Surface("incident", 10) = {1}; Physical Surface("specimen", 11) = {2}; Physical Surface("transmission", 12) = {3};

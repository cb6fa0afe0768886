// Half of a strip footing, 0.2 m wide in all, on a bed 0.8 m wide (half) and 0.5 m deep; finer towards its edge. Metres.
B = 0.10; W = 0.80; D = 0.50;
Point(1) = {0, 0, 0}; Point(2) = {B, 0, 0}; Point(3) = {W, 0, 0}; Point(4) = {W, D, 0}; Point(5) = {B, D, 0}; Point(6) = {0, D, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1}; Line(7) = {2, 5};
Transfinite Curve {1, -5} = 4; Transfinite Curve {2, -4} = 7 Using Progression 1.5;
Transfinite Curve {-6, 7, 3} = 8 Using Progression 0.7;
Curve Loop(1) = {1, 7, 5, 6}; Plane Surface(1) = {1};
Curve Loop(2) = {2, 3, 4, -7}; Plane Surface(2) = {2};
Transfinite Surface {1, 2}; Recombine Surface {1, 2};
Physical Curve("bottom", 1) = {1, 2}; Physical Curve("far", 2) = {3}; Physical Curve("surface", 3) = {4}; Physical Curve("footing", 4) = {5}; Physical Curve("symmetry", 5) = {6};
Physical Surface("sand", 10) = {1, 2};

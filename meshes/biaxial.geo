// Biaxial specimen, 50 x 100 mm, 8 x 16 quadrilaterals. Plane strain. Metres.
w = 0.050; h = 0.100;
Point(1) = {0, 0, 0}; Point(2) = {w, 0, 0}; Point(3) = {w, h, 0}; Point(4) = {0, h, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Transfinite Curve {1, 3} = 9; Transfinite Curve {2, 4} = 17;
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Surface {1}; Recombine Surface {1};
Physical Curve("bottom", 1) = {1}; Physical Curve("right", 2) = {2}; Physical Curve("top", 3) = {3}; Physical Curve("left", 4) = {4};
Physical Surface("sand", 10) = {1};

// A model pile of 16 mm, 40 mm deep, in sand; axisymmetric: x the radius, y the axis. Metres.
r = 0.008; n = 0.024; w = 0.060;          // radii of the pile, of the part with grains, of all
b = 0.040; t = 0.080; h = 0.120;          // heights of the lower end of the grains, of the tip, of the surface
Point(1) = {0, 0, 0};  Point(2) = {r, 0, 0};  Point(3) = {n, 0, 0};  Point(4) = {w, 0, 0};
Point(5) = {0, b, 0};  Point(6) = {r, b, 0};  Point(7) = {n, b, 0};  Point(8) = {w, b, 0};
Point(9) = {0, t, 0};  Point(10) = {r, t, 0}; Point(11) = {n, t, 0}; Point(12) = {w, t, 0};
Point(13) = {0, h, 0}; Point(14) = {r, h, 0}; Point(15) = {n, h, 0}; Point(16) = {w, h, 0};
For row In {0:3}
  For k In {1:3}
    Line(10*row + k) = {4*row + k, 4*row + k + 1};
  EndFor
  Transfinite Curve {10*row + 1} = 3; Transfinite Curve {10*row + 2} = 4; Transfinite Curve {10*row + 3} = 4 Using Progression 1.3;
EndFor
For row In {0:2}
  For k In {1:4}
    Line(100 + 10*row + k) = {4*row + k, 4*row + k + 4};
  EndFor
EndFor
Transfinite Curve {101:104} = 4 Using Progression 0.7; Transfinite Curve {111:114} = 7 Using Progression 0.85; Transfinite Curve {121:124} = 5;
For row In {0:2}
  For k In {1:3}
    Curve Loop(10*row + k) = {10*row + k, 100 + 10*row + k + 1, -(10*row + 10 + k), -(100 + 10*row + k)};
    Plane Surface(10*row + k) = {10*row + k};
  EndFor
EndFor
Transfinite Surface "*"; Recombine Surface "*";
Physical Curve("head") = {31}; Physical Curve("surface") = {32, 33}; Physical Curve("axis") = {101, 111, 121};
Physical Curve("far") = {104, 114, 124}; Physical Curve("bottom") = {1, 2, 3};
Physical Surface("pile") = {21}; Physical Surface("sand") = {11, 12, 22}; Physical Surface("ground") = {1, 2, 3, 13, 23};

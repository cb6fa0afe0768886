F = []
def f(room, name, file, old, new, **k): F.append(dict(room=room, name=name, file=file, old=old, new=new, set="third", **k))
E="fem/explicit_statics.cpp"; C="fem/central_differences.cpp"
f("explicit statics","inertial limit of the governor ignored",E,"o.inertial_number > 0 ? now.inertial_number / o.inertial_number : 0.0","0.0")
f("explicit statics","what mass scaling puts in is not booked",E,"now.energy.scaled += relax.scale_masses();","relax.scale_masses();")
f("explicit statics","element size of 2D by the cube root",E,"1.0 / p.dim","1.0 / 3")
f("explicit statics","no rest at the end of the load",E,"now.rested < rest","false")
f("explicit statics","steps pass over bends",E,"std::min(easing.next(now.load_factor), next + now.rate * easing(next, now.rate))","std::min(1.0, next + now.rate * easing(next, now.rate))")
f("explicit statics","drag may turn the motion round",C,"std::min(s.damping * std::sqrt(force2 / speed2), mass[n] / mean_dt)","s.damping * std::sqrt(force2 / speed2)")
f("explicit statics","first velocity without its energy",C,"v[i] = target(c), sums[0] += 0.5 * mass[i / p.width()] * v[i] * v[i];","v[i] = target(c);")

"""Makes kinematics.csv: where MuJoCo puts the bodies and geoms of an awkward robot. Needs mujoco (3.17.0 made it).

A row is qpos (14), then position and quaternion (w, x, y, z) of the five bodies and of the five geoms.
"""

import mujoco
import numpy as np

MODEL = mujoco.MjModel.from_xml_string("""
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <geom name="stone" type="sphere" size="0.2" pos="1 2 3"/>
    <body name="trunk" pos="0.1 0.2 1.3" quat="0.8 0 0.6 0">
      <freejoint/>
      <geom name="trunk" type="capsule" size="0.1 0.3" pos="0.05 0 -0.02" quat="0.6 0.8 0 0"/>
      <body name="arm" pos="0.3 -0.1 0.2" quat="0.5 0.5 -0.5 0.5">
        <joint name="reach" type="slide" axis="3 0 4" ref="0.3"/>
        <joint name="swing" type="hinge" axis="0 4 -3" pos="0.1 0.2 -0.3" ref="-0.4"/>
        <joint name="twist" type="hinge" axis="1 0 0" pos="0 -0.1 0.25"/>
        <geom name="arm" type="capsule" size="0.04 0.2" pos="0 0.1 0.2" quat="0.48 0.64 0.36 0.48"/>
        <body name="hand" pos="0 0.2 0.5" quat="0.8 0 0 -0.6">
          <joint name="wrist" type="hinge" axis="0 -1 0" pos="0.07 0 -0.02"/>
          <geom name="hand" type="sphere" size="0.06" pos="0.02 0.03 0.04"/>
        </body>
      </body>
      <body name="tail" pos="-0.4 0 0.1">
        <geom name="tail" type="capsule" size="0.02 0.15" quat="0 0.6 0 0.8"/>
      </body>
    </body>
    <body name="cart" pos="0 0 1.25">
      <joint name="x" type="slide" axis="1 0 0" pos="0 0 -1.25"/>
      <joint name="z" type="slide" axis="0 0 1" pos="0 0 -1.25" ref="1.25"/>
      <joint name="pitch" type="hinge" axis="0 1 0" pos="0 0 0.2"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    </body>
  </worldbody>
</mujoco>
""")

data, rng = mujoco.MjData(MODEL), np.random.default_rng(0)


def quat(matrix):
    out = np.empty(4)
    mujoco.mju_mat2Quat(out, matrix)
    return out


for row in range(5):
    # Quaternions after the first row are not of length 1: MuJoCo makes them so.
    data.qpos[:] = rng.uniform(-2.0, 2.0, MODEL.nq) if row else MODEL.qpos0
    numbers = [*data.qpos]
    mujoco.mj_kinematics(MODEL, data)
    for body in range(1, MODEL.nbody):
        numbers += [*data.xpos[body], *data.xquat[body]]
    for geom in range(MODEL.ngeom):
        numbers += [*data.geom_xpos[geom], *quat(data.geom_xmat[geom])]
    print(",".join(f"{x:.17g}" for x in numbers))

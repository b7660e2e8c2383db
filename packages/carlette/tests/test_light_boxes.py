"""`get_light_boxes` gives the heads of a light, where the cameras draw them."""

import numpy as np
import pytest

pytest.importorskip("carla")

from carlette.camera.models.traffic_lights import HEAD_HALF
from carlette.in_process import open_world


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_light_boxes_lie_where_heads_are_drawn() -> None:
    """The boxes of a light are where its heads are drawn.

    The instance camera shows the light's own id inside the boxes of heads that are in view.
    """
    import carla

    from stucksolver_carla.client_connection import connect
    from stucksolver_eval.simulator_server import carlette_server, set_synchronous
    from stucksolver_perception.rig import load_rig

    assert open_world("grid_town").signals is not None
    rig = load_rig().camera
    with carlette_server("grid_town", scenery=True) as server:
        world = connect(server, 20.0).get_world()
        set_synchronous(world, 0.05)
        light = world.get_actors().filter("*traffic_light*")[0]
        stop = light.get_stop_waypoints()[0]
        back = stop.previous(15.0)[0].transform
        back.location.z += 1.6
        blueprint = world.get_blueprint_library().find("sensor.camera.instance_segmentation")
        for name, value in (("image_size_x", rig.width_px), ("image_size_y", rig.height_px), ("fov", rig.fov_deg)):
            blueprint.set_attribute(name, str(value))
        pictures: list[carla.Image] = []
        camera = world.spawn_actor(blueprint, back)
        camera.listen(pictures.append)
        for _ in range(3):
            world.tick()
        while not pictures:
            world.tick()
        camera.stop()
        raw = np.frombuffer(pictures[-1].raw_data, np.uint8).reshape(rig.height_px, rig.width_px, 4)
        ids = raw[:, :, 1].astype(int) + 256 * raw[:, :, 0].astype(int)
        hit = 0
        for box in light.get_light_boxes():
            assert box.extent.z == pytest.approx(HEAD_HALF.z)
            inverse = np.array(back.get_inverse_matrix())
            x, y, z, _ = inverse @ np.array([box.location.x, box.location.y, box.location.z, 1.0])
            if x < 3.0:
                continue
            column, row = rig.width_px / 2 + rig.focal_px * y / x, rig.height_px / 2 - rig.focal_px * z / x
            if 0 <= column < rig.width_px and 0 <= row < rig.height_px:
                hit += int(ids[int(row), int(column)] == light.id)
        assert hit >= 1

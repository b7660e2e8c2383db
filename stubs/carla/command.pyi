"""What is used here of `carla.command`; each is one entry of a batch."""

from carla import Transform, Vector3D, VehicleControl, VehicleLightState, WalkerControl

class ApplyTransform:
    def __init__(self, actor_id: int, transform: Transform) -> None: ...

class ApplyTargetVelocity:
    def __init__(self, actor_id: int, velocity: Vector3D) -> None: ...

class ApplyVehicleControl:
    def __init__(self, actor_id: int, control: VehicleControl) -> None: ...

class ApplyWalkerControl:
    def __init__(self, actor_id: int, control: WalkerControl) -> None: ...

class SetSimulatePhysics:
    def __init__(self, actor_id: int, enabled: bool) -> None: ...

class SetVehicleLightState:
    def __init__(self, actor_id: int, state: VehicleLightState) -> None: ...

class DestroyActor:
    def __init__(self, actor_id: int) -> None: ...

"""A scene with its guard, and a chat model in the process, for tests of menus."""

from __future__ import annotations

from stucksolver.guard import Guard
from stucksolver.reasoners import ReasonerRequest
from stucksolver.scene import LineKind
from stucksolver.solver.state_machine.plan_preview import PlanPreview
from stucksolver_language.llm import ChatReply, Usage
from worlds import World, straight_road, thing

WORLD = World(straight_road(left=LineKind.BROKEN, oncoming=None), [thing("car", 60.0)])


def stopped(world=WORLD, **update):
    scene = world.scene()
    return scene.model_copy(update={"ego": scene.ego.model_copy(update={"stopped_for_s": 20.0}), **update})


def request_of(world=WORLD, scene=None, **more):
    preview = PlanPreview(Guard(), world.view(), lambda plan: False)
    return ReasonerRequest(stopped(world) if scene is None else scene, assess=preview.assess, **more)


class Scripted:
    """A chat model that gives these answers in turn, the last one again and again."""

    name = "scripted"

    def __init__(self, *answers):
        self.answers, self.asked = list(answers), []

    def chat(self, messages, tools, must_call, limit_s):
        self.asked.append((list(messages), list(tools)))
        text = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
        return ChatReply(text, (), Usage(100, 20), "scripted")

    def cancel(self):
        pass

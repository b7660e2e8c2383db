"""One decision in the forms in which models and servers give it.

The forms follow the public documentation of vLLM, SGLang, llama.cpp, Ollama, LM Studio, OpenRouter, OpenAI, Anthropic,
Gemini, Mistral, DeepSeek and of the models' chat templates. They stand here as data: the reader has no branch for any.
"""

from __future__ import annotations

import copy
import json

import mind
from chat_server import available_in

from stucksolver.reasoners.factory import make_reasoner
from stucksolver.scene import LineKind
from stucksolver_language.llm import LanguageModelReasoner, ModelSettings
from stucksolver_language.llm.prompt import messages
from worlds import World, straight_road, thing


def _scene():
    made = World(straight_road(left=LineKind.BROKEN, oncoming=None), [thing("car", 60.0)]).scene()
    return made.model_copy(update={"ego": made.ego.model_copy(update={"stopped_for_s": 20.0})})


SCENE = _scene()
GOOD = mind.answer(messages(SCENE)[1].text, available_in(messages(SCENE)[1].text))
GOOD["decision"]["rationale"] = 'It\'s a "parked" car, <6 m wide; pass it (left), then return.'
T = json.dumps(GOOD)
FENCED = f"```json\n{json.dumps(GOOD, indent=2)}\n```"
PLAN = [{"name": "creep", "distance_m": 2, "speed_mps": 1}]
OTHER = json.dumps({**GOOD, "decision": {**GOOD["decision"], "behaviors": None}})


def chat(content=None, finish="stop", choice=None, **message):
    """A response of chat completions with one message."""
    message = {"role": "assistant", "content": content, **message}
    body = {"index": 0, "message": message, "finish_reason": finish, **(choice or {})}
    return {"id": "x", "object": "chat.completion", "created": 1, "model": "m", "choices": [body]}


def called(arguments, name="decide", **entry):
    return {"id": "c1", "type": "function", "function": {"name": name, "arguments": arguments}, **entry}


def tools(*entries, content=None):
    return chat(content, "tool_calls", tool_calls=list(entries))


def stream(*deltas, finish="stop"):
    """Server-sent events, as of a server that streams although nobody asked for it."""
    lines = [": PROCESSING"]
    for i, delta in enumerate(deltas):
        choice = {"index": 0, "delta": delta, "finish_reason": finish if i == len(deltas) - 1 else None}
        lines.append("data: " + json.dumps({"id": "x", "object": "chat.completion.chunk", "choices": [choice]}))
    return "\n\n".join([*lines, "data: [DONE]", ""]).encode()


def each(form, joined="\n"):
    """Every argument in a form with its key and its JSON."""
    return joined.join(form.format(key=key, value=json.dumps(value)) for key, value in GOOD.items())


def gemma(value, mark):
    """A value in the notation of Gemma's calls."""
    if isinstance(value, dict):
        return "{" + ",".join(f"{key}:{gemma(item, mark)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ",".join(gemma(item, mark) for item in value) + "]"
    return f"{mark}{value}{mark}" if isinstance(value, str) else json.dumps(value)


QUOTE = '<|"|>'


def elements(value, mark=""):
    """A value as an element for each field and each item."""
    if isinstance(value, dict):
        return "".join(f"{mark}<{key}>{elements(item, mark)}{mark}</{key}>" for key, item in value.items())
    if isinstance(value, list):
        return "".join(f"{mark}<item>{elements(item, mark)}{mark}</item>" for item in value)
    return value if isinstance(value, str) else json.dumps(value)


KEYWORDS = ", ".join(f"{key}={value!r}" for key, value in GOOD.items())
JSON_KEYWORDS = ", ".join(f"{key}={json.dumps(value)}" for key, value in GOOD.items())
ENCODED = {key: json.dumps(value) for key, value in GOOD.items()}
INNER = copy.deepcopy(GOOD)
INNER["decision"]["behaviors"] = json.dumps(GOOD["decision"]["behaviors"])
ITEMS = copy.deepcopy(GOOD)
ITEMS["decision"]["behaviors"] = [json.dumps(item) for item in GOOD["decision"]["behaviors"]]
XML = each("<parameter={key}>\n{value}\n</parameter>")
NAMED = each('<parameter name="{key}">{value}</parameter>')
CALL = json.dumps({"name": "decide", "arguments": GOOD})
PARAMETERS = json.dumps({"name": "decide", "parameters": GOOD})
THOUGHT = "The car ahead is parked. {maybe} creep? No: pass it."

READ = {
    # JSON in the text
    "json": chat(T),
    "fence": chat(FENCED),
    "fence without a language": chat(f"```\n{T}\n```"),
    "fence between prose": chat(f"Here is my decision:\n\n{FENCED}\n\nStay safe!"),
    "json encoded as a string": chat(json.dumps(T)),
    "comma before the bracket": chat(T.replace("}]", "},]")),
    "python dict": chat(repr(GOOD)),
    "keys without quotes": chat(gemma(GOOD, '"').replace('"parked"', '\\"parked\\"')),
    "name as the key": chat(json.dumps({"decide": GOOD})),
    "under answer": chat(json.dumps({"answer": GOOD})),
    "answer tag": chat(f"<answer>{T}</answer>"),
    "boxed": chat(f"\\boxed{{{T}}}"),
    "end token of the template": chat(f"{T}<|im_end|>\n</s>"),
    "the same object twice": chat(f"{T}\n{T}"),
    "half of a character": chat(T.replace("pass it", "pass \\ud83d it")),
    # content that is not a text
    "text part": chat([{"type": "text", "text": T}]),
    "thinking and text (Mistral)": chat(
        [{"type": "thinking", "thinking": [{"type": "text", "text": THOUGHT}]}, {"type": "text", "text": T}]
    ),
    "closed thinking, fenced text": chat(
        [
            {"type": "thinking", "thinking": [{"type": "text", "text": T}], "closed": True},
            {"type": "text", "text": FENCED},
        ]
    ),
    "reference between": chat(
        [
            {"type": "text", "text": T[:90]},
            {"type": "reference", "reference_ids": [1]},
            {"type": "text", "text": T[90:]},
        ]
    ),
    "output text": chat([{"type": "output_text", "text": T, "annotations": []}]),
    "list of strings": chat([T]),
    "thinking with a signature": chat(
        [{"type": "thinking", "thinking": THOUGHT, "signature": "EqQBCg=="}, {"type": "text", "text": T}]
    ),
    "tool_use part": chat(
        [{"type": "text", "text": "Passing."}, {"type": "tool_use", "id": "t", "name": "decide", "input": GOOD}]
    ),
    "one part, no list": chat({"type": "text", "text": T}),
    "object as the content": chat(GOOD),
    # function calls
    "call": tools(called(T)),
    "arguments as an object": tools(called(GOOD)),
    "arguments encoded twice": tools(called(json.dumps(T))),
    "arguments in a fence": tools(called(FENCED)),
    "arguments in the arguments": tools(called(json.dumps({"arguments": GOOD}))),
    "each argument encoded": tools(called(json.dumps(ENCODED))),
    "list encoded": tools(called(json.dumps(INNER))),
    "items encoded": tools(called(json.dumps(ITEMS))),
    "functions.decide": tools(called(T, "functions.decide")),
    "default_api.decide": tools(called(T, "default_api.decide")),
    "channel in the name (gpt-oss)": tools(called(T, "decide<|channel|>commentary")),
    "number in the name (Kimi)": tools(called(T, "functions.decide:0")),
    "no list of calls": chat(None, tool_calls=called(T)),
    "flat call": tools({"id": "1", "name": "decide", "arguments": T}),
    "flat call with parameters": tools({"type": "function", "name": "decide", "parameters": GOOD}),
    "identical calls": tools(called(T), called(T, id="c2")),
    "decision beside a check": tools(called(json.dumps({"behaviors": PLAN}), "check_plan"), called(T, id="c2")),
    "call without arguments, json in the text": tools(called("{}"), content=T),
    "no calls": chat(T, tool_calls=[]),
    "legacy function_call": chat(None, "function_call", function_call={"name": "decide", "arguments": T}),
    "legacy function_call with an object": chat(None, function_call={"name": "decide", "arguments": GOOD}),
    "call with a thought signature": tools(called(T, extra_content={"google": {"thought_signature": "AY89=="}})),
    # thoughts
    "reasoning_content beside": chat(T, reasoning_content=OTHER),
    "only in reasoning_content": chat("", reasoning_content=f"{THOUGHT}\n{T}"),
    "only in reasoning": chat(None, reasoning=T, reasoning_details=[{"type": "reasoning.text", "text": T}]),
    "only in a thinking part": chat([{"type": "thinking", "thinking": [{"type": "text", "text": FENCED}]}]),
    "call in reasoning_content": chat(None, reasoning_content=f"<tool_call>\n{CALL}\n</tool_call>"),
    "think block with drafts": chat(f'<think>\n{THOUGHT} {{"decision": 1}} {OTHER}\n</think>\n\n{T}'),
    "end of think only": chat(f"{THOUGHT} {OTHER}\n</think>\n\n{T}"),
    "think never closed": chat(f"<think>\n{THOUGHT}\n{T}"),
    "all inside think": chat(f"<think>{T}</think>"),
    "[THINK] (Magistral)": chat(f"[THINK]{THOUGHT} {OTHER}[/THINK]{T}"),
    "◁think▷ (Kimi)": chat(f"◁think▷{OTHER}◁/think▷{T}"),
    "seed:think": chat(f"<seed:think>{OTHER}</seed:think>{T}"),
    "START_THINKING (Cohere)": chat(f"<|START_THINKING|>{OTHER}<|END_THINKING|>{T}"),
    "scratch_pad (Hermes)": chat(f"<scratch_pad>{OTHER}</scratch_pad><tool_call>{CALL}</tool_call>"),
    # calls as tags
    "tool_call (Hermes)": chat(f"<tool_call>\n{CALL}\n</tool_call>"),
    "tool_call with a python dict": chat(f"<tool_call>{json.loads(CALL)!r}</tool_call>"),
    "tools (Qwen2.5-Coder)": chat(f"<tools>\n{CALL}\n</tools>"),
    "function= (Qwen3-Coder)": chat(f"<tool_call>\n<function=decide>\n{XML}\n</function>\n</tool_call>"),
    "function= without its frame": chat(f"Passing.\n<function=decide>\n{XML}\n</function>"),
    "parameters never closed": chat(
        "<function=decide>" + each("<parameter={key}>\n{value}\n") + "</function></tool_call>"
    ),
    "function= with json (Llama)": chat(f"<function=decide>{T}</function>"),
    "seed:tool_call": chat(f"<seed:tool_call><function=decide>{XML}</function></seed:tool_call>"),
    "arg_key (GLM 4.5)": chat(
        "<tool_call>decide\n" + each("<arg_key>{key}</arg_key>\n<arg_value>{value}</arg_value>") + "\n</tool_call>"
    ),
    "arg_key in one line (GLM 4.7)": chat(
        "<tool_call>decide" + each("<arg_key>{key}</arg_key><arg_value>{value}</arg_value>", "") + "</tool_call>"
    ),
    "invoke (MiniMax M2)": chat(
        f'<minimax:tool_call>\n<invoke name="decide">\n{NAMED}\n</invoke>\n</minimax:tool_call>'
    ),
    "invoke (Anthropic)": chat(f'<function_calls>\n<invoke name="decide">\n{NAMED}\n</invoke>\n</function_calls>'),
    "DSML (DeepSeek V3.2)": chat(
        '<｜DSML｜function_calls>\n<｜DSML｜invoke name="decide">\n'
        + each('<｜DSML｜parameter name="{key}" string="false">{value}</｜DSML｜parameter>')
        + "\n</｜DSML｜invoke>\n</｜DSML｜function_calls>"
    ),
    "steptml (Step 3)": chat(
        '<｜tool_calls_begin｜><｜tool_call_begin｜>function<｜tool_sep｜><steptml:invoke name="decide">'
        + each('<steptml:parameter name="{key}">{value}</steptml:parameter>', "")
        + "</steptml:invoke><｜tool_call_end｜><｜tool_calls_end｜>"
    ),
    "DSML (DeepSeek V4)": chat(
        '<think>\nhm\n</think>\n<|DSML|tool_calls>\n<|DSML|invoke name="decide">\n'
        + each('<|DSML|parameter name="{key}" string="false">{value}</|DSML|parameter>')
        + "\n</|DSML|invoke>\n</|DSML|tool_calls>"
    ),
    "DSML with spaces (DeepSeek V4.1)": chat(
        '<｜DSML｜ calls>\n<｜DSML｜ invoke name="decide">\n'
        + each('<｜DSML｜ parameter name="{key}" string="false">{value}</｜DSML｜ parameter>')
        + "\n</｜DSML｜ invoke>\n</｜DSML｜ calls>"
    ),
    "arg_key with a suffix (Hunyuan 4)": chat(
        "<tool_calls:61c7><tool_call:61c7>decide"
        + each("<arg_key:61c7>{key}</arg_key:61c7><arg_value:61c7>{value}</arg_value:61c7>", "")
        + "</tool_call:61c7></tool_calls:61c7>"
    ),
    "elements between marks (MiniMax M3)": chat(
        f']<]minimax[>[<tool_call>\n]<]minimax[>[<invoke name="decide">{elements(GOOD, "]<]minimax[>[")}'
        "]<]minimax[>[</invoke>\n]<]minimax[>[</tool_call>"
    ),
    "open and close (Kimi K3)": chat(
        f"<|open|>think<|sep|>{OTHER}<|close|>think<|sep|><|open|>tools<|sep|>"
        '<|open|>call tool="decide" index="0"<|sep|>'
        + each('<|open|>argument key="{key}" type="object"<|sep|>{value}<|close|>argument<|sep|>', "")
        + "<|close|>call<|sep|><|close|>tools<|sep|>"
    ),
    "blocks (Inkling)": chat(
        f"<|message_model|><|content_thinking|>{OTHER}<|end_message|><|message_model|><|content_invoke_tool_json|>"
        + json.dumps({"name": "decide", "args": GOOD})
        + "<|end_message|>"
    ),
    "an element for each field": chat(f"<decide>{elements(GOOD)}</decide>"),
    "an element for each argument": chat("<decide>\n" + each("<{key}>{value}</{key}>") + "\n</decide>"),
    # calls in Python's notation
    "pythonic (Llama 3.2)": chat(f"[decide({KEYWORDS})]"),
    "pythonic (LFM2)": chat(f"<|tool_call_start|>[decide({KEYWORDS})]<|tool_call_end|>"),
    "pythonic with json": chat(f"decide({JSON_KEYWORDS})"),
    "pythonic (Olmo 3)": chat(f"<function_calls>\ndecide({KEYWORDS})\n</function_calls>"),
    "tool_code (Gemma 3)": chat(f"```tool_code\ndecide({KEYWORDS})\n```"),
    "print(default_api…) (Gemini)": chat(f"```tool_code\nprint(default_api.decide({KEYWORDS}))\n```"),
    "call with one object": chat(f"decide({T})"),
    "call: (Gemma 4)": chat(f"<|tool_call>call:decide{gemma(GOOD, QUOTE)}<tool_call|>"),
    "call: (FunctionGemma)": chat(f"<start_function_call>call:decide{gemma(GOOD, '<escape>')}<end_function_call>"),
    # calls between the templates' own tokens
    "[TOOL_CALLS] list (Mistral)": chat(f"[TOOL_CALLS][{CALL}]"),
    "[ARGS] (Mistral)": chat(f"[TOOL_CALLS]decide[CALL_ID]9xYz[ARGS]{T}"),
    "python_tag (Llama 3.1)": chat(f"<|python_tag|>{PARAMETERS}<|eom_id|>"),
    "DeepSeek V3": chat(
        "<｜tool▁calls▁begin｜><｜tool▁call▁begin｜>function<｜tool▁sep｜>decide\n"
        f"{FENCED}<｜tool▁call▁end｜><｜tool▁calls▁end｜>"
    ),
    "DeepSeek V3.1": chat(f"<｜tool▁calls▁begin｜><｜tool▁call▁begin｜>decide<｜tool▁sep｜>{T}<｜tool▁call▁end｜>"),
    "Kimi K2": chat(
        "<|tool_calls_section_begin|><|tool_call_begin|>functions.decide:0<|tool_call_argument_begin|>"
        f"{T}<|tool_call_end|><|tool_calls_section_end|>"
    ),
    "START_ACTION (Cohere)": chat(
        "<|START_ACTION|>"
        + json.dumps([{"tool_call_id": "0", "tool_name": "decide", "parameters": GOOD}])
        + "<|END_ACTION|>"
    ),
    "tool_call list (Granite)": chat(f"<|tool_call|>[{CALL}]"),
    "functools (Phi 4)": chat(f"functools[{CALL}]"),
    "action_start (InternLM)": chat(f"<|action_start|><|plugin|>{PARAMETERS}<|action_end|>"),
    "TOOLCALL (Nemotron)": chat(f"<TOOLCALL>[{CALL}]</TOOLCALL>"),
    ">>> (Functionary)": chat(f">>>decide\n{T}"),
    "ReAct": chat(f"Thought: pass it.\nAction: decide\nAction Input: {T}"),
    "action and action_input": chat(json.dumps({"action": "decide", "action_input": GOOD})),
    "tool_uses": chat(json.dumps({"tool_uses": [{"recipient_name": "functions.decide", "parameters": GOOD}]})),
    "tool_calls in the text": chat(json.dumps({"tool_calls": [called(T)]})),
    "commentary channel (gpt-oss)": chat(
        f"<|channel|>analysis<|message|>{OTHER}<|end|><|start|>assistant<|channel|>commentary to=functions.decide "
        f"<|constrain|>json<|message|>{T}<|call|>"
    ),
    "final channel (gpt-oss)": chat(
        f"<|channel|>analysis<|message|>{OTHER}<|end|><|start|>assistant<|channel|>final<|message|>{T}<|return|>"
    ),
    "thought channel (Gemma 4)": chat(f"<|channel>thought\n{OTHER}<channel|>{T}"),
    # how it ended
    "whole at the token limit": chat(T, "length"),
    "whole under a filter": chat(T, "content_filter"),
    "whole before an error": chat(T, "error", {"error": {"code": 502, "message": "upstream dropped"}}),
    "whole beside an error": {**chat(T), "error": {"code": 429, "message": "slow down"}},
    "empty refusal": chat(T, refusal=""),
    "refusal beside the answer": chat(T, refusal="I must be careful."),
    "nothing but the text": {"choices": [{"message": {"content": T}}]},
    "text of a completion": {"choices": [{"text": T, "index": 0, "finish_reason": "stop"}]},
    # other protocols that proxies pass on
    "blank lines first": b"\n\n\n" + json.dumps(chat(T)).encode(),
    "byte order mark": b"\xef\xbb\xbf" + json.dumps(chat(T)).encode(),
    "stream of text": stream({"role": "assistant", "content": ""}, {"content": T[:50]}, {"content": T[50:]}),
    "stream with reasoning": stream({"reasoning_content": OTHER}, {"content": T}, {}),
    "stream of a call": stream(
        {"tool_calls": [{"index": 0, "id": "a", "type": "function", "function": {"name": "decide", "arguments": ""}}]},
        {"tool_calls": [{"index": 0, "function": {"arguments": T[:70]}}]},
        {"tool_calls": [{"index": 0, "function": {"arguments": T[70:]}}]},
        finish="tool_calls",
    ),
    "stream of Ollama": "\n".join(
        json.dumps({"model": "m", "message": {"role": "assistant", "content": part}, "done": part == T[80:]})
        for part in (T[:80], T[80:])
    ).encode(),
    "Ollama": {"model": "m", "message": {"role": "assistant", "content": T}, "done": True, "done_reason": "stop"},
    "Ollama, a call": {"message": {"content": "", "tool_calls": [{"function": {"name": "decide", "arguments": GOOD}}]}},
    "Anthropic": {
        "type": "message",
        "role": "assistant",
        "content": [{"type": "tool_use", "id": "t", "name": "decide", "input": GOOD}],
        "stop_reason": "tool_use",
    },
    "Gemini": {
        "candidates": [
            {"content": {"parts": [{"functionCall": {"name": "decide", "args": GOOD}}]}, "finishReason": "STOP"}
        ]
    },
    "Gemini, thought and text": {
        "candidates": [{"content": {"parts": [{"text": OTHER, "thought": True}, {"text": T}]}}]
    },
    "OpenAI responses, a call": {
        "object": "response",
        "status": "completed",
        "output": [
            {"type": "reasoning", "summary": []},
            {"type": "function_call", "call_id": "c", "name": "decide", "arguments": T},
        ],
    },
    "OpenAI responses, text": {
        "output": [{"type": "message", "role": "assistant", "content": [{"type": "output_text", "text": T}]}]
    },
}


CHECK = json.dumps({"behaviors": PLAN})
CHECKS = {
    "call": tools(called(CHECK, "check_plan")),
    "arguments encoded twice": tools(called(json.dumps(CHECK), "check_plan")),
    "list encoded": tools(called(json.dumps({"behaviors": json.dumps(PLAN)}), "check_plan")),
    "written as json": chat(json.dumps({"name": "check_plan", "arguments": {"behaviors": PLAN}})),
    "written without a name": chat(f"<function=check_plan>{CHECK}</function>"),
    "written as tags": chat(f"<function=check_plan><parameter=behaviors>{json.dumps(PLAN)}</parameter></function>"),
    "written in Python": chat(f"[check_plan(behaviors={PLAN!r})]"),
    "in a part": chat([{"type": "tool_use", "id": "t", "name": "check_plan", "input": {"behaviors": PLAN}}]),
}


def reasoner_at(server, options="", deadline_s=20.0):
    made = make_reasoner(f"openai:reader@{server.url}{options}")
    return LanguageModelReasoner(made.model, settings=ModelSettings(deadline_s=deadline_s))


def bytes_of(body):
    return body if isinstance(body, bytes) else json.dumps(body).encode()

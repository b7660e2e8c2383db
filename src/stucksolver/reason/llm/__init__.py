"""A general language model as a reasoner: prompt, chain of thought and function calling, zero-shot."""

from stucksolver.reason.llm.answer import AnswerError, parse_answer
from stucksolver.reason.llm.chat import ChatModel, ChatReply, GiveUp, Message, Tool, ToolCall, TryAgain, Usage
from stucksolver.reason.llm.limits import Budget, BudgetSpent, Price, UsageLimits
from stucksolver.reason.llm.reasoner import LanguageModelReasoner, ModelSettings

__all__ = [
    "AnswerError",
    "Budget",
    "BudgetSpent",
    "ChatModel",
    "ChatReply",
    "GiveUp",
    "LanguageModelReasoner",
    "Message",
    "ModelSettings",
    "Price",
    "Tool",
    "ToolCall",
    "TryAgain",
    "Usage",
    "UsageLimits",
    "parse_answer",
]

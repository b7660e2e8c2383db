"""A general language model as a reasoner: prompt, chain of thought and function calling, zero-shot."""

from stucksolver_language.llm.answer_parser import AnswerError, parse_answer
from stucksolver_language.llm.chat import ChatModel, ChatReply, GiveUp, Message, Tool, ToolCall, TryAgain, Usage
from stucksolver_language.llm.llm_reasoner import LanguageModelReasoner, ModelSettings
from stucksolver_language.llm.usage_budget import Budget, BudgetSpent, Price, UsageLimits

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

"""The measure-synchronous motion graph: which step can follow which, and which one is danced next."""

"""Independent checks of the validation pages and of the tests: each number beside another's."""

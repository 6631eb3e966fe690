"""Methods that go from contact to contact: the problem's form, the law at one contact, the sweeps and when to stop."""
